"""What a scene would run, cost and err, and what it lacks."""
