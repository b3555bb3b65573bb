#!/usr/bin/env bash
# Joins all shards into the data set that one run would have written, byte for byte, and checks it: every file against its
# checksum, and some links by computing them anew.
#
# Written by: @COMMAND@
@OPTIONS@
set -eu

@PROGRAM@ dataset merge --out @OUT@
@PROGRAM@ @VERIFY@ --threads "$SLURM_CPUS_ON_NODE"
