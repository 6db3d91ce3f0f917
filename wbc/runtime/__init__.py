"""The loop: what takes part in it, its clock and conditions, its ticks and its report."""
