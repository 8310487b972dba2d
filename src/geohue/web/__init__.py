"""``geohue serve``: a page that shows, tunes and corrects segmentations, and its JSON API.

`app.make_app` is the application, `server.serve` runs it. Needs the extra ``web``.
"""
