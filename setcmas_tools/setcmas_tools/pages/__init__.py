"""Pages that open without a server: their templates, and what makes them safe to open."""
