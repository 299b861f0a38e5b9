"""Ready case files, listed and copied out by ``directrix examples``."""
