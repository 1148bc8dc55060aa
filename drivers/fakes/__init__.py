"""Shipped models of chips, pins and drives below the vendor libraries; each says its limits."""
