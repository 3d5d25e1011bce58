"""All checks by name."""

from importlib import import_module

GROUPS = """checks games promises pursuits induced regions dumps questions tables whole valued together stopping sweeps places
    lists nested several exchange names wild pages refusals package tasks policies memory attained"""
ALL = {name: check for group in GROUPS.split() for name, check in import_module(f"tester.{group}").ALL.items()}
