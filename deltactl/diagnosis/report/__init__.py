"""What a diagnosis says to people.

In: a `Diagnosis`. Out: its sentences, from the templates in `sentences.yaml`, and one HTML file.
What decides stands in the answer; the rules for pairs of findings stand in `pairs`.
"""
