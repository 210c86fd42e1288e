"""ROS domains: which numbers there are, and which of them systems share with other programs."""

LARGEST_DOMAIN = 232

SHARED_DOMAINS = range(102, 215)
"""Linux gives the ports of these to other programs, too."""
