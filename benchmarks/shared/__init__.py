"""What several benchmarks use: recorded walks, observed loops, clients, synthetic robots."""
