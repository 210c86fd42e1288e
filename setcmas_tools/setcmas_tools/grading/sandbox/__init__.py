"""The sandbox: processes that hold submissions, and may do nothing but answer."""
