"""The window: commands, task panels, work in progress. Nothing here computes."""
