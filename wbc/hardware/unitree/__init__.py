"""Unitree's low-level interface for humanoids, and a simulated robot that speaks it."""
