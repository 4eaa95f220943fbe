"""Many voyages at once: clocks side by side in one sea, and fleets of one clock."""
