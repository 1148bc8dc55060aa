"""Drives that take a current and tell an encoder count: their contract and a fake."""
