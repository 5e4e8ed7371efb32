"""Tools: algorithms on arrays and nouns, explicit keyword parameters, no configuration."""
