"""The safety layer between any controller and any hardware."""
