# Texts as a C++ source: cmake -DOUT=viewer.cpp -DFRAME=page.html -DSTYLE=page.css -DSCRIPT=page.js (or empty) -DLICENCE=LICENSE -P embed.cmake.
# In pieces, since a literal has a limit of length.
set(source "#include \"viewer.hpp\"\n#include <string>\n\nnamespace camber {\nnamespace {\n")
foreach(part FRAME STYLE SCRIPT)
    set(text "")
    string(TOLOWER ${part} name)
    if(${part})
        file(READ "${${part}}" text)
        if(name STREQUAL "script")
            file(READ "${LICENCE}" licence) # of three.js, which goes with every copy of it
            string(REPLACE "©" "(c)" licence "${licence}") # pieces are of bytes: none may end within a character
            string(APPEND text "/* three.js:\n${licence}*/\n")
        endif()
    endif()
    string(LENGTH "${text}" length)
    string(APPEND source "const char* const ${name}_[] = {\n")
    set(begin 0)
    while(begin LESS length OR begin EQUAL 0)
        string(SUBSTRING "${text}" ${begin} 32000 piece)
        string(APPEND source "R\"camber~(${piece})camber~\",\n")
        math(EXPR begin "${begin} + 32000")
    endwhile()
    string(APPEND source "};\n")
endforeach()
string(APPEND source "template <class Pieces>
std::string joined(const Pieces& pieces) {
    std::string text;
    for (const char* piece : pieces) text += piece;
    return text;
}
}  // namespace
Viewer viewer() { return {joined(frame_), joined(style_), joined(script_)}; }
}  // namespace camber
")
file(WRITE "${OUT}" "${source}")
