"""Plans of a hand that presses against a surface."""
