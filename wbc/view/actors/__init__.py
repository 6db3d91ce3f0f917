"""Actors: each owns some nodes of the scene and updates their poses."""
