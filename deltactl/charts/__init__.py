"""Charts for reports: one HTML file, no network, zoomed with mouse, touch or keyboard."""
