"""What the browser view shows (pure modules), and how viser draws it (`*_scene`, `page`, ...)."""
