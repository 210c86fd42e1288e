"""Scene of the view: shapes in three dimensions."""
