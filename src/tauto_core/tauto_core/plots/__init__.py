"""Pictures and pages of voyages: contents, chart, machine, cutting, page."""
