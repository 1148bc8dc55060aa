"""What a run leaves behind: MCAP channels, their writer and reader, flat tables."""
