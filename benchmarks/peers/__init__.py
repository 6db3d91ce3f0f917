"""Compares the tick with that of other whole-body controllers on the same recorded states.

`compare` is the entry point (`python benchmarks/tick.py --peers`); README.md explains the results.
`case`, `measuring` and `worker` run in the environment of every peer and need numpy only; each
library has one module in `adapters`.
"""
