"""Mutation run: what is changed (operators, named), against which tests (table), and by whom."""
