"""What a recorded run shows: tracking errors, sensor health, and a report to look at."""
