"""Control loop: its protocols, its clock and run conditions, its ticks and its report."""
