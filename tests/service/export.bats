# quietgear export: what other programs make of it, and what it refuses.

load helper

setup() {
    quietgear=$QG_BUILD/quietgear
    standard=$QG_SOURCE/schema/examples/case_S_standard.json
    cd "$BATS_TEST_TMPDIR"
}

need() {
    command -v "$1" >/dev/null || skip "$1 is not installed"
}

# Exports document $1 at position $2 and share $3 of the torque, has CalculiX solve it, sets `error` (um) and `balance`.
calculix() {
    "$quietgear" export --format abaqus "$1" -o deck.inp --position "$2" --torque-fraction "$3"
    OMP_NUM_THREADS=1 ccx deck >log 2>&1 3>&-
    read -r error balance < <(awk -f "$QG_SOURCE/tests/service/calculix.awk" deck.inp deck.dat)
}

# Asserts that $1 is within the share $3 of $2.
near() {
    echo "found $1, wanted $2 to $3 of it" >&2
    awk -v a="$1" -v b="$2" -v share="$3" 'BEGIN { exit !(a - b <= share * b && b - a <= share * b) }'
}

@test "CalculiX finds our static transmission error of case S on the exported deck: 3 positions, 2 torques" {
    need ccx
    if sanitized; then skip "CalculiX has the same deck from the plain build"; fi
    jq '.load_cases = [{"torque_fraction": 0.33}, {"torque_fraction": 1}]
        | .analysis = {"mesh_positions": 14, "speeds": {"count": 1}}' "$standard" >job.json
    "$quietgear" run job.json -o result.json
    for i in 0 3 7; do
        for k in 0 1; do
            ours=$(jq ".design.load_cases[$k].static_transmission_error_um[$i]" result.json)
            calculix job.json "$(jq -n "$i / 14")" "$(jq ".load_cases[$k].torque_fraction" job.json)"
            echo "position $i/14, load case $k: CalculiX $error um, ours $ours um" >&3
            near "$error" "$ours" 0.015
            near "$balance" 1 0.0005
        done
    done
}

@test "the deck follows plane, bore, widths and reliefs: CalculiX agrees on a clamped pinion in plane strain" {
    need ccx
    if sanitized; then skip "CalculiX has the same deck from the plain build"; fi
    jq '.load_cases = [{"torque_fraction": 1}] | .gear_pair.pinion.face_width_mm = 20
        | .relief.shape = "parabolic" | .relief.pinion.root = {"end_radius_mm": 41.5, "amplitude_mm": 0.008}
        | .analysis = {"mesh_positions": 4, "plane": "strain", "bore": "clamped", "harmonics": 1,
                       "speeds": {"count": 1}}' "$standard" >job.json
    "$quietgear" run job.json -o result.json
    # a quarter period before mid path, where the pinion's root relief is part of the gap
    calculix job.json 0.25 1
    near "$error" "$(jq '.design.load_cases[0].static_transmission_error_um[1]' result.json)" 0.015
    near "$balance" 1 0.0005
}

@test "Gmsh reads the mesh and all views" {
    need gmsh
    "$quietgear" export --format gmsh "$standard" -o pair.msh
    echo 'Printf("views %g", PostProcessing.NbViews); Printf("largest %g", View[1].Max);' >ask.geo
    gmsh pair.msh ask.geo -check -parse_and_exit >log 2>&1 3>&-
    cat log
    run ! grep -Ei '^(warning|error)' log
    grep -q "$(sed -n '/^\$Nodes/{n;p;q}' pair.msh | cut -d' ' -f2) nodes" log
    grep -q 'views 4' log
    largest=$(awk '/^\$EndNodeData/ { inside = 0 } inside && NF == 2 && $2 > most { most = $2 }
        /^"von_mises"/ { inside = 1 } END { print most }' pair.msh)
    near "$(sed -n 's/.*largest //p' log)" "$largest" 1e-4
}

@test "the VTK file holds what it announces" {
    "$quietgear" export --format vtk "$standard" --load-case 0 -o pair.vtk
    awk '/^POINTS/ { points = $2; left = points; next }
         /^CELLS/ { cells = $2; if ($3 != 9 * cells) exit 1; for (i = 0; i < cells; i++) { getline; if (NF != 9 || $1 != 8) exit 1
             for (k = 2; k <= 9; k++) if ($k < 0 || $k >= points) exit 1 } next }
         /^CELL_TYPES/ { for (i = 0; i < $2; i++) { getline line; if (line != "23") exit 1 } next }
         /^POINT_DATA/ { if ($2 != points) exit 1; data = 1; next }
         data && /^(VECTORS|SCALARS|stress)/ { blocks++; rows[blocks] = 0; next }
         data && NF && $1 ~ /^-?[0-9]/ { rows[blocks]++ }
         END { for (b = 1; b <= 4; b++) if (rows[b] != points) exit 1; exit !(blocks == 4 && cells > 10000) }' pair.vtk
    run ! grep -Eqi 'nan|inf|null' pair.vtk
    if command -v gmsh >/dev/null; then # which reads the mesh of such files
        gmsh pair.vtk -parse_and_exit >log 2>&1 3>&-
        grep -q "Reading $(awk '/^CELLS/ { print $2 }' pair.vtk) cells" log
        run ! grep -Ei '^(warning|error)' log
    fi
}

@test "the field for a page is below 500 KB, in balance with itself, and knows the load case" {
    "$quietgear" export --format json "$standard" -o field.json
    [ "$(wc -c <field.json)" -lt 500000 ]
    jq -e '(.static_transmission_error_um - 38.12 | fabs) < 0.1 and .torque_nm == 470 and .mesh_position == 0.5' field.json
    jq -e '[.pinion, .gear | (.x_mm | length) as $n | ([.y_mm, .displacement_x_um, .displacement_y_um, .von_mises_mpa,
        .max_principal_mpa] | all(length == $n)) and ([.quads[][]] | max == $n - 1)] | all' field.json
    # the pinion has turned counter-clockwise: its nodes move the way of (-y, x)
    jq -e '.pinion as $p | [range(0; $p.x_mm | length) | $p.x_mm[.] * $p.displacement_y_um[.]
        - $p.y_mm[.] * $p.displacement_x_um[.]] | add > 0' field.json
    jq -e '[.contact[].pair] | unique == [0]' field.json
    "$quietgear" export --format json "$standard" --load-case 0 | jq -e '.torque_nm == 155.1'
    "$quietgear" export --format json "$standard" --position 0 | jq -e '[.contact[].pair] | unique == [0, 1]'
}

@test "the same field for any number of threads" {
    "$quietgear" export --format json "$standard" --threads 1 -o one.json
    "$quietgear" export --format json "$standard" --threads 4 -o four.json
    cmp one.json four.json
}

@test "without options the deck is at mid path under the largest torque" {
    "$quietgear" export --format abaqus "$standard" >plain.inp
    "$quietgear" export --format abaqus "$standard" --position 0.5 --torque-fraction 1 >same.inp
    "$quietgear" export --format abaqus "$standard" --load-case 2 >case.inp
    cmp plain.inp same.inp
    cmp plain.inp case.inp
    grep -q '^\*\* mesh position 0.5 periods, torque on the pinion 470000 N mm$' plain.inp
    "$quietgear" export --format abaqus "$standard" --load-case 0 | grep -q 'torque on the pinion 155100 N mm'
}

@test "no line of a deck is longer than CalculiX reads, no number longer than 20 characters, all is ASCII" {
    jq '.name = "Ü *STEP" | .gear_pair.name = "\u2028*STEP"' "$standard" >strange.json
    "$quietgear" export --format abaqus strange.json >deck.inp
    awk 'length($0) > 130 { exit 1 }' deck.inp
    grep -v '^\*' deck.inp | tr ', ' '\n\n' | awk 'length($0) > 20 { exit 1 }'
    [ "$(LC_ALL=C tr -d '\012\040-\176' <deck.inp | wc -c)" -eq 0 ]
    [ "$(grep -c '^\*STEP' deck.inp)" -eq 1 ]
}

@test "a wrong command line is status 2 and says what is allowed" {
    while IFS='|' read -r words wanted; do
        # shellcheck disable=SC2086 # words
        quietly "$quietgear" export $words
        echo "$words: $status $(cat err)"
        [ "$status" -eq 2 ] && [ ! -s out ]
        grep -qF -- "$wanted" err
    done <<END
$standard|--format: not given, allowed abaqus, vtk, gmsh, json, dxf or dxf-spaces
--format nastran $standard|--format: found nastran, allowed abaqus, vtk, gmsh, json, dxf or dxf-spaces
--format abaqus $standard --position 1.01|--position: found 1.01, allowed 0 to 1
--format abaqus $standard --position -0.1|--position: found -0.1, allowed 0 to 1
--format abaqus $standard --position nan|--position: found nan, allowed 0 to 1
--format abaqus $standard --position half|--position: found half, allowed 0 to 1
--format abaqus $standard --torque-fraction 0|--torque-fraction: found 0, allowed 0.001 to 10
--format abaqus $standard --torque-fraction 11|--torque-fraction: found 11, allowed 0.001 to 10
--format abaqus $standard --load-case 3|--load-case: found 3, allowed 0 to 2
--format abaqus $standard --load-case -1|--load-case: found -1, allowed 0 to 2
--format abaqus $standard --load-case first|--load-case: found first, allowed 0 to 2
--format abaqus $standard --load-case 1 --torque-fraction 1|--load-case: found 1, allowed only without
--format abaqus $standard --key k|the option -k does not go with export
--format abaqus|found 1 word
--format abaqus $QG_SOURCE/tests/schema/bad/range_teeth_few.json|/gear_pair/pinion/teeth: found 3, allowed 5 to 1000
--format abaqus nowhere.json|nowhere.json: No such file or directory
END
    for command in run check; do
        quietly "$quietgear" "$command" "$standard" --position 0.5
        [ "$status" -eq 2 ]
        grep -q "the option -P does not go with $command" err
    done
}

@test "a deck that cannot be written is status 1" {
    quietly "$quietgear" export --format abaqus "$standard" -o nowhere/deck.inp
    [ "$status" -eq 1 ]
    grep -q '^nowhere/deck.inp: No such file or directory$' err
}

@test "a signal in the middle of an export leaves no file behind, and an older one alone" {
    jq '.analysis.mesh_refinement = 4' "$standard" >fine.json
    echo old >fine.vtk
    for signal in INT TERM HUP; do
        for delay in 0.4 0.1 0; do # shorter when the export was faster
            env --default-signal="$signal" "$quietgear" export --format vtk fine.json -o fine.vtk 2>err &
            pid=$!
            sleep "$delay"
            kill -s "$signal" "$pid" || true
            status=0
            wait "$pid" || status=$?
            [ "$status" -eq 0 ] || break
            echo old >fine.vtk
        done
        [ "$status" -gt 128 ]
        [ "$(cat fine.vtk)" = old ]
        [ "$(ls | grep -c 'fine.vtk')" -eq 1 ]
    done
}
