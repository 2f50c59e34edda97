# usage: awk -f faults.awk -v mode=MODE [-v root=PROJECT] faults.txt
#   mode=list                          a line a fault, with | between: number, name, what catches it, flags, text of the refusal, files
#   mode=check                         applies each fault in memory and says what is wrong with the table; exit status 1 if anything is
#   mode=move                          prints the table; a place whose text has moved to one other file names that file
#   mode=plant -v fault=NN -v out=DIR  writes the files that fault NN changes into DIR, and prints their names; DIR has their folders
# The format of the table is explained in its first lines.

function fail(line, text) { print "faults.txt:" line ": " text > "/dev/stderr"; failed = 1 }

# ---- lines of a place and lines of a file
function indentation(s) { match(s, /^ */); return RLENGTH }
function spaces(n) { return n > 0 ? sprintf("%" n "s", "") : "" }
function trimmed(s) { sub(/^ +/, "", s); return s }
# What line `s` of a file has behind line `pattern` of a place: nothing, a comment, or "no" where they differ.
function tail(s, pattern,    rest) {
    s = trimmed(s); pattern = trimmed(pattern)
    if (substr(s, 1, length(pattern)) != pattern) return "no"
    rest = substr(s, length(pattern) + 1)
    return rest == "" || rest ~ /^ +\/\/ / ? rest : "no"
}

# ---- files: original[file, i] and now[file, i], of lines[file] and lines_now[file] lines
function load(file,    path, line, n) {
    if (file in lines) return lines[file]
    path = root "/" file
    while ((getline line < path) > 0) original[file, ++n] = line
    close(path)
    return lines[file] = n + 0
}
function begin_changes(file,    i) {
    load(file)
    if (file in lines_now) return
    lines_now[file] = lines[file]
    for (i = 1; i <= lines[file]; ++i) now[file, i] = original[file, i]
}
function forget_changes(    file) { for (file in lines_now) delete lines_now[file] }
# How often the old text of place p is in a file; `first_hit` is the line of the first.
function occurrences(p, file,    hits, i, k) {
    begin_changes(file)
    hits = 0
    for (i = 1; i + olds[p] - 1 <= lines_now[file]; ++i) {
        for (k = 1; k <= olds[p] && tail(now[file, i + k - 1], old[p, k]) != "no"; ++k);
        if (k <= olds[p]) continue
        if (++hits == 1) first_hit = i
    }
    return hits
}
# Replaces the old text of place p, which begins at line `at` of its file.
function replace(p, at,    file, shift, made, n, i, k, text, behind, run, run_end, minus, plus) {
    file = file_of[p]
    shift = indentation(now[file, at]) - indentation(old[p, 1])
    for (i = 1; i < at; ++i) made[++n] = now[file, i]
    for (k = 1; k <= rows[p]; ++k) {
        if (sign[p, k] == " ") { made[++n] = now[file, i++]; continue }
        # A run of - and + lines. Where there are as many of either, comments that the - lines leave out stay.
        minus = plus = 0
        for (run_end = k; run_end <= rows[p] && sign[p, run_end] != " "; ++run_end) {
            if (sign[p, run_end] == "-") behind[++minus] = tail(now[file, i++], row[p, run_end])
            else ++plus
        }
        run = plus == minus
        plus = 0
        for (; k < run_end; ++k) {
            if (sign[p, k] == "-") continue
            text = trimmed(row[p, k])
            ++plus
            made[++n] = text == "" ? "" : spaces(indentation(row[p, k]) + shift) text (run ? behind[plus] : "")
        }
        --k
    }
    for (; i <= lines_now[file]; ++i) made[++n] = now[file, i]
    for (i = 1; i <= n; ++i) now[file, i] = made[i]
    lines_now[file] = n
}

# ---- hints for a place that no longer matches
function load_all(    command, file) {
    if (files) return
    command = "cd '" root "' && find include examples bench -name '*.?pp' | sort"
    while ((command | getline file) > 0) { every_file[++files] = file; load(file) }
    close(command)
}
# The one other file that has the old text of place p once, or "".
function moved_to(p,    i, hits, found, where) {
    load_all()
    for (i = 1; i <= files; ++i) {
        if (every_file[i] == file_of[p]) continue
        hits = occurrences(p, every_file[i])
        if (hits == 0) continue
        if (hits > 1 || found != "") return ""
        found = every_file[i]
        where = first_hit
    }
    hit_elsewhere = where
    return found
}
function words(s, into,    n, k, part, count) {
    gsub(/[^A-Za-z0-9_]+/, " ", s)
    for (k in into) delete into[k]
    n = split(s, part, " ")
    for (k = 1; k <= n; ++k) if (!(part[k] in into)) { into[part[k]] = 1; ++count }
    return count + 0
}
# The line of the project that has most words in common with line `s`.
function nearest(s, prefer,    i, k, n, w, mine, theirs, a, b, common, score, best, answer) {
    load_all()
    a = words(s, mine)
    for (i = 1; i <= files; ++i) {
        n = lines[every_file[i]]
        for (k = 1; k <= n; ++k) {
            b = words(original[every_file[i], k], theirs)
            if (b == 0) continue
            common = 0
            for (w in theirs) if (w in mine) ++common
            score = 2 * common / (a + b) + (every_file[i] == prefer ? 0.1 : 0)
            if (score > best) { best = score; answer = every_file[i] ":" k ": " trimmed(original[every_file[i], k]) }
        }
    }
    return best > 0.4 ? answer : ""
}

# ---- faults
# Applies fault f in memory. With `loud`, says what does not match.
function apply(f, loud,    p, hits, elsewhere, near, ok, k, gone) {
    forget_changes()
    ok = 1
    for (p = first_place[f]; p <= last_place[f]; ++p) {
        hits = occurrences(p, file_of[p])
        if (hits == 1) { replace(p, first_hit); continue }
        ok = 0
        if (!loud) continue
        for (k = 1; k < rows[p] && sign[p, k] != "-"; ++k);
        if (hits > 1) {
            fail(place_line[p], "fault " number[f] " " name[f] ": its text is " hits " times in " file_of[p] ", first in line " first_hit ": " trimmed(row[p, k]))
            continue
        }
        gone = lines[file_of[p]] == 0 ? " (there is no such file)" : ""
        fail(place_line[p], "fault " number[f] " " name[f] ": its text is not in " file_of[p] gone ": " trimmed(row[p, k]))
        elsewhere = moved_to(p)
        if (elsewhere != "") { print "    moved to " elsewhere ":" hit_elsewhere > "/dev/stderr"; ++movable; continue }
        for (k = 1; k <= olds[p] && occurs(old[p, k], file_of[p]); ++k);
        near = nearest(k <= olds[p] ? old[p, k] : old[p, 1], file_of[p])
        if (near != "") print "    nearest: " near > "/dev/stderr"
    }
    return ok
}
function occurs(text, file,    i) {
    for (i = 1; i <= lines[file]; ++i) if (tail(original[file, i], text) != "no") return 1
    return 0
}
function check(f,    n, part, i, line, p, k, seen, path, read, before, after) {
    line = fault_line[f]
    if (sentence[f] == "") fail(line, "fault " number[f] " has no sentence that says what is wrong")
    if (caught_by[f] == "") fail(line, "fault " number[f] " has no line \"caught by: part/file\"")
    if (number[f] in numbers) fail(line, "there are two faults " number[f])
    numbers[number[f]] = 1
    n = split(caught_by[f], part, " ")
    for (i = 1; i <= n; ++i) {
        path = root "/tests/" part[i] (part[i] ~ /^checks\// ? ".sh" : ".cpp")
        seen = part[i] ~ /^checks\//
        while ((read = (getline k < path)) > 0 && !seen) seen = k ~ /TEST_CASE/
        close(path)
        if (read < 0) fail(line, "fault " number[f] " is caught by " part[i] ", which does not exist")
        else if (!seen) fail(line, "fault " number[f] " is caught by " part[i] ", which has no test case")
    }
    if (first_place[f] > last_place[f]) fail(line, "fault " number[f] " has no line \"file: ...\"")
    for (p = first_place[f]; p <= last_place[f]; ++p) {
        if (olds[p] == 0) fail(place_line[p], "fault " number[f] " says nothing of where in " file_of[p])
        before = after = ""
        for (i = 1; i <= rows[p]; ++i) {
            if (sign[p, i] != "+") before = before row[p, i] "\n"
            if (sign[p, i] != "-") after = after row[p, i] "\n"
        }
        if (before == after) fail(place_line[p], "fault " number[f] " changes nothing in " file_of[p])
    }
    apply(f, 1)
}

# ---- the table
{ sub(/\r$/, "") }
mode == "move" { table[FNR] = $0 }
/^(#|$)/ { next }
/^== / {
    if ($0 !~ /^== [0-9]+ [a-z0-9_]+$/) { fail(FNR, "\"== NUMBER name_of_the_fault\" is expected"); unreadable = 1 }
    f = ++faults
    number[f] = $2; name[f] = $3; fault_line[f] = FNR
    first_place[f] = places + 1; last_place[f] = places
    next
}
f == 0 { fail(FNR, "text before the first fault"); unreadable = 1; next }
/^caught by: / { caught_by[f] = trimmed(substr($0, 11)); next }
/^flags: / { flags[f] = trimmed(substr($0, 8)); next }
/^does not compile: / { refusal[f] = trimmed(substr($0, 19)); next }
/^file: / {
    last_place[f] = ++places
    file_of[places] = trimmed(substr($0, 7)); place_line[places] = FNR
    next
}
/^[-+ ]( |$)/ && last_place[f] >= first_place[f] {
    p = places
    row[p, ++rows[p]] = substr($0, 3)
    sign[p, rows[p]] = substr($0, 1, 1)
    if (sign[p, rows[p]] != "+") old[p, ++olds[p]] = substr($0, 3)
    next
}
sentence[f] == "" && first_place[f] > last_place[f] { sentence[f] = $0; next }
{ fail(FNR, "this line is none of a fault's: " $0); unreadable = 1 }

END {
    if (unreadable) exit 1
    if (mode == "list") {
        for (f = 1; f <= faults; ++f) {
            changes = ""
            for (p = first_place[f]; p <= last_place[f]; ++p) changes = changes " " file_of[p]
            print number[f] "|" name[f] "|" caught_by[f] "|" flags[f] "|" refusal[f] "|" substr(changes, 2)
        }
    } else if (mode == "check") {
        for (f = 1; f <= faults; ++f) check(f)
        if (movable) print movable " of these places have moved as they were: run.sh --move names their new files" > "/dev/stderr"
        print faults " faults in " places " places"
    } else if (mode == "move") {
        for (f = 1; f <= faults; ++f) {
            forget_changes()
            for (p = first_place[f]; p <= last_place[f]; ++p) {
                if (occurrences(p, file_of[p]) > 0) continue
                moved = moved_to(p)
                if (moved != "") table[place_line[p]] = "file: " moved
            }
        }
        for (i = 1; i <= FNR; ++i) print table[i]
    } else if (mode == "plant") {
        for (f = 1; f <= faults && number[f] != fault; ++f);
        if (f > faults) { fail(FNR, "there is no fault " fault); exit 1 }
        if (!apply(f, 1)) exit 1
        for (p = first_place[f]; p <= last_place[f]; ++p) changed[file_of[p]] = 1
        for (file in changed) {
            printf "" > (out "/" file)
            for (i = 1; i <= lines_now[file]; ++i) print now[file, i] > (out "/" file)
            close(out "/" file)
            print file
        }
    }
    exit failed
}
