"""Page of the view: server, panel, buttons, cameras."""
