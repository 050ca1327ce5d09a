# bash completion for the programs of qs-tools; one file for all, it reads the program's own --help.

_qs_tools() {
    local program=$1 current=$2 previous=$3 help subcommands words
    COMPREPLY=()

    # A subcommand, as in `qs-path orbit`, has a help of its own.
    local subcommand=() word
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        [[ $word == -* ]] || { subcommand=("$word"); break; }
    done
    help=$("$program" --help 2>/dev/null)
    subcommands=$(sed -n '/^Subcommands:/,/^[^ ]/{s/^  \([a-z][a-z-]*\).*/\1/p}' <<<"$help")
    if [[ ${#subcommand[@]} -gt 0 ]] && grep -qx -- "${subcommand[0]}" <<<"$subcommands"; then
        help+=$'\n'$("$program" "${subcommand[0]}" --help 2>/dev/null)
        subcommands=
    fi

    # Help names the few words that an option takes as a|b|c or as "a, b or c".
    if [[ $previous == -* ]]; then
        local choices
        # The option's line and those that go on with it.
        choices=$(awk -v option="$previous" '
                /^ *-/ { found = index(" " $0 " ", " " option " ") || index(" " $0, " " option ",") }
                /^ *$/ { found = 0 }
                found' <<<"$help" | tr -s ' \n' ' ' |
            grep -oE '([a-z0-9]+\|)+[a-z0-9]+|([a-z0-9]+, )+[a-z0-9]+ or [a-z0-9]+' | head -n 1 | sed 's/ or / /; s/[|,]/ /g')
        if [[ -n $choices ]]; then
            COMPREPLY=($(compgen -W "$choices" -- "$current"))
            return
        fi
    fi
    if [[ $current == -* ]]; then
        words=$(grep -oE -- '(^|[ ,])--[a-z][a-z0-9-]*' <<<"$help" | tr -d ' ,' | sort -u)
        COMPREPLY=($(compgen -W "$words" -- "$current"))
    else
        compopt -o filenames 2>/dev/null
        COMPREPLY=($(compgen -W "$subcommands" -- "$current") $(compgen -f -- "$current"))
    fi
}

complete -F _qs_tools qs-build qs-info qs-path qs-render qs-view qs-compare qs-fetch pm-build ppve-sample pm-serve pm-fetch
