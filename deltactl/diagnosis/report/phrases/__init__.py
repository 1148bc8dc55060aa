"""What sentences are made of: names of effects and parts, sizes with units, how sure.

In: fields of an answer. Out: phrases, and the sentences on fit and limits that need nothing else.
"""
