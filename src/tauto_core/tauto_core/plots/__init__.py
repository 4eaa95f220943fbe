"""Pictures and pages of voyages: contents, machine, renderer, page."""
