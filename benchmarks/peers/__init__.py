"""The tick of other whole-body controllers on the same recorded states.

`compare` is the entry (`python benchmarks/tick.py --peers`); README.md tells how to read it.
`case`, `measuring` and `worker` run in every peer's environment and need nothing but numpy;
one module under `adapters` per library.
"""
