"""Modules shared by several benchmarks: recordings, observed loops, clients, robots."""
