"""Scoring submissions: suites, the isolated agent, the episode loop, the referee, metrics and results."""
