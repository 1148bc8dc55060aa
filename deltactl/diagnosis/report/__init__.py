"""What a diagnosis says to people.

In: a `Diagnosis`. Out: its sentences (`sentences`, made of `phrases`) and one HTML file (`page`,
`drawing`).
"""
