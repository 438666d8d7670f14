"""What a solid must satisfy: topology, geometry and volume, checked on the tables alone.

The modeller is not asked here; in the tests it is the oracle.
"""
