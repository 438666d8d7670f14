"""From a request to a finished design: settings, each layer's terms, the chain and its certificate.

The only place where all layers meet. Files are written by `export`, templates live in `catalog`.
"""
