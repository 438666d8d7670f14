"""perfqr-cad: perforated QR codes as parts that can be printed, cut or opened in a CAD suite."""

__version__ = "0.1.0"
