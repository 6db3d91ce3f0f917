"""Planning of reaching: positions both hands can reach, closest postures, paths of the arms."""
