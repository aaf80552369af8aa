"""Blocks of scenarios, the text they are written in, and how both become validated models."""
