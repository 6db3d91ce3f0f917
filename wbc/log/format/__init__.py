"""The MCAP file format: records, chunks and the summary section.

The `mcap` package is not used, for two reasons: at 8000 messages per second its writer took two
thirds of the log's CPU time, and it cannot read and complete a truncated file. Tests read every
log with that package and with two other independent readers.
"""
