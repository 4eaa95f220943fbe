"""Checks of a scene before it sails: propagator, cost, error, and effects left out."""
