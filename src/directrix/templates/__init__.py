"""Cases to begin with: what `directrix new` writes."""
