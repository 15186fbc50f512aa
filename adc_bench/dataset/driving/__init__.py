"""Scripted drivers who know the truth: missions as legs to be driven, a tracker, and the errors of its hand."""
