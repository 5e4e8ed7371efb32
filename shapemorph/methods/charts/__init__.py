"""Several charts of one surface: how it is split, laid side by side, and put together again."""
