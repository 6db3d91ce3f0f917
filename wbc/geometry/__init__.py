"""Plane geometry, smooth polynomials and contact wrenches, without any robot model."""
