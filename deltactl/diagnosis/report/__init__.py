"""What a diagnosis says to people.

In: a `Diagnosis`. Out: its sentences, from the templates in `sentences.yaml`, and one HTML file.
The answer holds what decides; `pairs` holds the rules for pairs of findings.
"""
