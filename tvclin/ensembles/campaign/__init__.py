"""Campaigns: many dispersed cases, written to a folder in chunks, with confidence."""
