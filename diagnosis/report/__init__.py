"""What a diagnosis says to people: a summary for the terminal, and one HTML file."""
