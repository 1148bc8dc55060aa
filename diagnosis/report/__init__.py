"""What a diagnosis says to people.

In: a `Diagnosis`. Out: its sentences (`sentences`) and one HTML file (`page`, `drawing`).
"""
