# Reads an exported deck, then what CalculiX printed of it; prints the static transmission error in micrometres and the
# moment of the reactions at the gear's bore about the pinion's axis, over the torque: 1 when everything is in balance.
# Both are of the last increment. The deck's comments hold the figures that turn the one into the other.
BEGIN { FS = "[ ,]+" }
FNR == NR && /^\*\* mesh position/ { for (i = 1; i <= NF; i++) if ($i == "pinion") torque = $(i + 1) }
FNR == NR && /^\*\* seat =/ { seat = $4 }
FNR == NR && /U1 of node set RING times/ { ratio = $NF }
FNR == NR && /^\*/ { nodes = /^\*NODE, NSET=ALL_NODES/; next }
FNR == NR { if (nodes) { x[$1] = $2; y[$1] = $3 } next }
/for set/ { what = /RING/ ? "ring" : "bore"; if (what == "bore") moment = 0; next }
NF >= 5 && what == "ring" { turn = $3 }
NF >= 5 && what == "bore" { moment += x[$2] * $4 - y[$2] * $3 }
END { printf "%.6f %.6f\n", 1000 * (seat + ratio * turn), -moment / torque }
