"""Shipped models of the chips, pins and drives below the vendor libraries; each says what it leaves out."""
