"""Whole-body kinematics and control of humanoids on Pinocchio."""
