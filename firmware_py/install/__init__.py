"""Putting the service onto a Raspberry Pi: files, users, boot options, wiring."""
