"""The MCAP file format: its records, its chunks and its end.

Written here, not with the `mcap` package, for two reasons: a log has 8000 messages per second,
of which that package's writer made two thirds of the log's cost; and a file that just stops
must be read and completed. Tests read every log with that package and with readers of two other
makes.
"""
