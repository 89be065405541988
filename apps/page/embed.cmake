# Writes the viewer's texts as a C++ source: cmake -DOUT=viewer.cpp -P embed.cmake. Literals have a maximum length, so texts are cut into pieces.
set(here "${CMAKE_CURRENT_LIST_DIR}")
file(STRINGS "${here}/bundle/sources.sha256" lines REGEX "^[^#]")
foreach(line IN LISTS lines)
    string(REGEX MATCH "^([0-9a-f]+)  (.+)$" line "${line}")
    file(SHA256 "${here}/${CMAKE_MATCH_2}" sum)
    if(NOT sum STREQUAL CMAKE_MATCH_1)
        message(FATAL_ERROR "apps/page/${CMAKE_MATCH_2} has changed since the viewer was bundled. Run ./x viewer")
    endif()
endforeach()

file(READ "${here}/src/page.html" frame)
file(READ "${here}/src/page.css" style)
file(READ "${here}/bundle/page.js" script)
file(READ "${here}/bundle/LICENSE.three" licence) # part of every copy of three.js
string(REPLACE "©" "(c)" licence "${licence}") # pieces are of bytes: none may end within a character
string(APPEND script "/* three.js:\n${licence}*/\n")

set(source "#include \"viewer.hpp\"\n#include <string>\n\nnamespace camber {\nnamespace {\n")
foreach(name IN ITEMS frame style script)
    string(LENGTH "${${name}}" length)
    string(APPEND source "const char* const ${name}_[] = {\n")
    set(begin 0)
    while(begin LESS length)
        string(SUBSTRING "${${name}}" ${begin} 32000 piece)
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
