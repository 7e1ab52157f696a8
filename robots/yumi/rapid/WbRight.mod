MODULE WbRight
    ! The right arm; loaded into T_ROB_R beside WbMove.

    CONST num my_arm:=1;
    CONST string my_name:="right";
    CONST jointtarget my_home:=[[0,-130,30,0,40,0],[-135,9E9,9E9,9E9,9E9,9E9]];

    PROC main()
        wb_obey;
    ENDPROC
ENDMODULE
